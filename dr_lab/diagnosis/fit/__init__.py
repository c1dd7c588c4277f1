"""A model fitted to windows: residuals, their slopes, Levenberg–Marquardt, uncertainty."""

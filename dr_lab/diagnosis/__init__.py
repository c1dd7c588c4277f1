"""How a gap between model and measurement is measured, explained and closed."""

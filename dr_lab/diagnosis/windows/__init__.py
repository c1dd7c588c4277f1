"""Logs cut into windows: channels, commands, and where each window starts."""

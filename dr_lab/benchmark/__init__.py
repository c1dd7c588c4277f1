"""The cases of a benchmark: logs with a known truth, their diagnosis, and how the answers are scored."""

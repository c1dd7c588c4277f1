"""Reports of runs: JSON for programs, Markdown and sentences for people."""

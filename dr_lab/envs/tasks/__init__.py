"""The tasks: one a file, each with a yaml in ``conf/env``."""

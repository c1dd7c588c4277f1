"""The command line: verbs composed by Hydra, checked, and handed to plain functions of `dr_lab.workflows`."""

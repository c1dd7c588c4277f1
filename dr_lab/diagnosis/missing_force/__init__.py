"""The force that a model lacks, and a formula of it."""

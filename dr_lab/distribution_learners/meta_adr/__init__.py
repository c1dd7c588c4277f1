"""Meta-ADR: particles that seek the tasks in which adapting changes what a policy does."""

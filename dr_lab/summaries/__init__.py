"""Many runs as one: what differs between them, their figures, and what they show together."""

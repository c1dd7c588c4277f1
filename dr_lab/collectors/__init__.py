"""How batches of experience are gathered: TorchRL's own, a lean one, and one over several machines."""

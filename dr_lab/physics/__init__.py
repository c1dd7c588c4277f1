"""The simulated machine: parameters, contexts, models and the batched simulator."""

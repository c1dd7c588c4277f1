"""Which effect is missing: candidates screened, ranked and judged, and the ladder of models."""

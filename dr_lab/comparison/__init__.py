"""What the comparing verbs share: model and measurements, the ladder that is climbed, the report and its files."""

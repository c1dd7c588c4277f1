"""Where `record` takes logs from: a plant, a model with chosen effects, CSV files."""

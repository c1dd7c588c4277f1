"""Active domain randomisation: particles that seek the contexts where simulation and reference part."""

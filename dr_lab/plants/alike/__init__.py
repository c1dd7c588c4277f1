"""Which effects given logs cannot tell from the hidden one, worked out from the truth itself.

Nothing here shares code with the diagnosis: neither simulation, nor fit, nor the laws of the catalogue. Noise-free motion
of the true machine is put into the equations of the machine without its effect; the force that is missing there, and what
the encoders read wrongly, is regressed on what each rival would give along the same motion.
"""

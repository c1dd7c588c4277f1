"""Which effects given logs cannot tell from the hidden one, worked out from the truth itself.

Nothing here shares code with the diagnosis: neither simulation, nor fit, nor the laws of the catalogue. Noise-free
motion of the true machine is put into the equations of the machine without its effect; the force that is missing there,
and what the encoders read wrongly, is regressed on what each rival would give along the same motion. Where a rival
comes near, what is left is small, so that the motion may be linearised about the true one; where it does not come near,
how far off it is does not matter.
"""

"""REINFORCE: the score-function gradient of whole episodes."""

"""SimOpt: the distribution of simulations moves to where they go as the real machine does."""

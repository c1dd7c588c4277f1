"""gymnasium's LunarLander-v3, played by Box2D in as many processes as there are cores."""

"""A trained policy on its way to the robot: what goes in and comes out, as a file, and in a control loop."""

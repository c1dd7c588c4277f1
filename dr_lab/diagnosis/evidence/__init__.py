"""Whether one model explains data better than another: scores, paired gains, confirmation."""

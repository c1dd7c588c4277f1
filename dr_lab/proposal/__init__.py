"""What a user has, a robot's description and logs, to a model and measurements that the verbs take."""

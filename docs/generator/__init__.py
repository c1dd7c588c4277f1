"""The pages of the documentation that are made from the classes and from conf/ at every build."""

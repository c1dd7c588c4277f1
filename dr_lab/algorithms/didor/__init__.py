"""Distilled domain randomisation: policies that each master one context teach one that is deployed."""

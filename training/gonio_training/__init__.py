"""Trains the networks that gonio ships. One command a step: train, evaluate, export, parity."""

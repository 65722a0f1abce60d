"""The theory of a swarm's decision, without a fitted parameter: a second opinion on the engine."""

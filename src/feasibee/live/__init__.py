"""The live arena: a server for one's own machine, and a page that shows swarms step by step."""

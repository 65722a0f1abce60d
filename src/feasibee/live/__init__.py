"""The live arena: a local web server, its page, and a notebook widget, which show swarms step by step."""

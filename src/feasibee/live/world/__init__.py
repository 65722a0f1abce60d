"""The world of `feasibee page`: in C, compiled to WebAssembly."""

"""The world of `feasibee page`: the paper's, in C, compiled to WebAssembly."""

"""The processes of `feasibee launch --ros`: those of feasibee.field, whose robots and world are nodes."""

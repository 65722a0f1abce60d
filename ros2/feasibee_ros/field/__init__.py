"""The processes of `feasibee robot launch --ros`: as feasibee.field, with robots and world as nodes."""

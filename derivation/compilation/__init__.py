"""From equations of motion to machine code, kept on disk."""

"""The verdict, as the file that others read (`fusion-verdict/1`)."""

"""The compilers of kernels, each behind the same names: what is made for one of them stays in its file."""

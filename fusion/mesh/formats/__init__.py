"""One file per mesh format: what it promises is held against what it holds, and is handed on to the library that reads.

Each gives bytes in which nothing is left that was not looked at; ValueError where not all is there.
"""

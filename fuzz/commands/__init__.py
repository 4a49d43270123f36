"""Commands of the fuzzer."""

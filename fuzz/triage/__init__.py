"""Turn a run that did not arrive into a failure: certified, judged and sorted into a bucket."""

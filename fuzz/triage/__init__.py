"""From a run that did not arrive to a classified failure: certified, judged, put into a bucket."""

// Counts the elements that each contact model examines, per thread; work.h reads the counts.
#pragma once

#include "haptics/work.h"

namespace typodont::haptics {

// initial-exec: with the default TLS model, each access from a shared library (libtypodont.so) calls a function.
[[gnu::tls_model("initial-exec")]] extern constinit thread_local SearchCounts t_search_counts;

}  // namespace typodont::haptics

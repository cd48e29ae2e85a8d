// Counts per thread how often models searched tissue near the head, by form of the tissue; work.h reads the counters.
#pragma once

#include "haptics/work.h"

namespace typodont::haptics {

// TLS model: in a shared library (libtypodont.so) the default model calls a function at each access.
[[gnu::tls_model("initial-exec")]] extern constinit thread_local SearchCounts t_search_counts;

}  // namespace typodont::haptics

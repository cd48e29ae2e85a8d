// Counts per thread the tissue elements that models examined near the head, by contact model; work.h reads the
// counters.
#pragma once

#include "haptics/work.h"

namespace typodont::haptics {

// Sets the TLS model. In a shared library (libtypodont.so), the default model calls a function at each access.
[[gnu::tls_model("initial-exec")]] extern constinit thread_local SearchCounts t_search_counts;

}  // namespace typodont::haptics

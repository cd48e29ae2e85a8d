// Counters, one set per thread: how many tissue elements each contact model examined near the head. work.h reads them.
#pragma once

#include "haptics/work.h"

namespace typodont::haptics {

// Selects the initial-exec TLS model. With the default TLS model, code in a shared library (libtypodont.so) calls a
// function at each access.
[[gnu::tls_model("initial-exec")]] extern constinit thread_local SearchCounts t_search_counts;

}  // namespace typodont::haptics

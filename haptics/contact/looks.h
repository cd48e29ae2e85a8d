// Elements examined by each model, per thread; read by work.h.
#pragma once

#include "haptics/work.h"

namespace typodont::haptics {

// initial-exec: in a shared library (libtypodont.so) the default calls a function per access.
[[gnu::tls_model("initial-exec")]] extern constinit thread_local SearchCounts t_search_counts;

}  // namespace typodont::haptics

// Counts how often this thread looked for tissue near the head, by the form that the tissue has: read by work.h.
#pragma once

#include "haptics/work.h"

namespace typodont::haptics {

// The TLS model: in a shared library (libtypodont.so) the default one calls a function at each access.
[[gnu::tls_model("initial-exec")]] extern constinit thread_local ModelLooks t_looks;

}  // namespace typodont::haptics

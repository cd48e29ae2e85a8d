#include "haptics/contact/looks.h"

namespace typodont::haptics {

constinit thread_local SearchCounts t_search_counts;

SearchCounts looks_of_this_thread() noexcept {
  return t_search_counts;
}

}  // namespace typodont::haptics

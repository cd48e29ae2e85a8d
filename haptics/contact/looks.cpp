#include "haptics/contact/looks.h"

namespace typodont::haptics {

constinit thread_local ModelLooks t_looks;

ModelLooks looks_of_this_thread() noexcept {
  return t_looks;
}

}  // namespace typodont::haptics

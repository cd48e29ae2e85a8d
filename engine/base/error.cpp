#include "engine/base/error.h"

namespace typodont {

static std::string compose(std::string_view file, std::string_view where, std::string_view found,
                           std::string_view expected) {
  std::string text(file);
  if (!where.empty()) text.append(": ").append(where);
  if (!found.empty()) text.append(": found ").append(found);
  if (!expected.empty()) text.append(", expected ").append(expected);
  return text;
}

Error::Error(std::string_view file, std::string_view where, std::string_view found, std::string_view expected)
    : std::runtime_error(compose(file, where, found, expected)) {}

}  // namespace typodont

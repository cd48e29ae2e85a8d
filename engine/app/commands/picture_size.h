// The option --size WIDTHxHEIGHT of commands that draw.
#pragma once

#include <glm/glm.hpp>
#include <string>

namespace typodont {

/// Pixels of one eye's picture. Throws Error.
glm::ivec2 parse_size(const std::string& text);

}  // namespace typodont

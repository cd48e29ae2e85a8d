// `typodont sound page`: compares a recording with its model.
#pragma once

namespace typodont {

namespace cli {
class Command;
}

void add_sound_page_command(cli::Command& sound);

}  // namespace typodont

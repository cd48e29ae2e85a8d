// typodont sound page and sound abx: pages that a person listens to.
#pragma once

namespace typodont {

namespace cli {
class Command;
}

void add_sound_page_command(cli::Command& sound);
void add_sound_abx_command(cli::Command& sound);

}  // namespace typodont

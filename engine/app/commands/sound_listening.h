// The commands `typodont sound page` and `typodont sound abx`: they write pages with sounds for listening tests.
#pragma once

namespace typodont {

namespace cli {
class Command;
}

void add_sound_page_command(cli::Command& sound);
void add_sound_abx_command(cli::Command& sound);

}  // namespace typodont

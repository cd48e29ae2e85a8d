#include "engine/app/work_counts.h"

#include <link.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>

namespace typodont {

namespace {
constinit std::atomic<std::uint64_t> g_allocations{0};
}  // namespace

void count_allocation() noexcept {
  g_allocations.fetch_add(1, std::memory_order_relaxed);
}

std::array<WorkCount, 26> listed(const WorkCounts& c) {
  return {{{"ticks", "ticks of the servo", c.ticks},
           {"queries", "queries of the field", c.queries},
           {"sphere_looks", "searches for spheres (packing)", c.sphere_looks},
           {"triangle_looks", "searches for triangles (mesh_lod)", c.triangle_looks},
           {"vertex_looks", "searches for vertices (vertex)", c.vertex_looks},
           {"patches", "patches cut out for the servo", c.patches},
           {"voxels_cut", "voxels visited by cuts", c.voxels_cut},
           {"voxels_redistanced", "voxels re-distanced: a cut keeps the field's distances, so none ever", 0},
           {"bricks_meshed", "bricks meshed", c.bricks_meshed},
           {"triangles_made", "triangles made", c.triangles_made},
           {"frames", "frames drawn", c.frames},
           {"passes", "render passes", c.passes},
           {"triangles_drawn", "triangles drawn", c.triangles_drawn},
           {"bricks_skipped", "bricks not drawn: out of sight, facing away or covered", c.bricks_skipped},
           {"pipelines", "shader pipelines", c.pipelines},
           {"turns", "loops of the render thread", c.turns},
           {"desktop_requests", "requests to the desktop", c.desktop_requests},
           {"samples", "samples of sound", c.samples},
           {"particles_stepped", "particles stepped", c.particles_stepped},
           {"droplets_stepped", "droplets stepped", c.droplets_stepped},
           {"film_cells_stepped", "cells of the film stepped", c.film_cells_stepped},
           {"film_texels", "texels of the film written", c.film_texels},
           {"allocations", "allocations", c.allocations},
           {"threads", "threads", c.threads},
           {"libraries", "libraries loaded", c.libraries},
           {"bytes_written", "bytes written", c.bytes_written}}};
}

WorkCounts process_counts() {
  WorkCounts c;
  c.allocations = g_allocations.load(std::memory_order_relaxed);
  std::error_code code;
  for (auto it = std::filesystem::directory_iterator("/proc/self/task", code);
       !code && it != std::filesystem::directory_iterator(); it.increment(code))
    ++c.threads;
  dl_iterate_phdr(
      [](dl_phdr_info* info, std::size_t, void* count) {
        if (info->dlpi_name && *info->dlpi_name) ++*static_cast<std::uint64_t*>(count);
        return 0;
      },
      &c.libraries);
  std::ifstream io("/proc/self/io");
  for (std::string key; io >> key;) {
    std::uint64_t value = 0;
    if (!(io >> value)) break;
    if (key == "wchar:") c.bytes_written = value;
  }
  timespec t{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  c.cpu_seconds = static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
  return c;
}

double seconds_since_command() {
  std::ifstream in("/proc/self/stat");
  const std::string line((std::istreambuf_iterator<char>(in)), {});
  // Skips the process's name, because it may contain any character.
  std::istringstream fields(line.substr(std::min(line.rfind(')') + 1, line.size())));
  constexpr int kStartTime = 20;  // index of the field "starttime"; the field after the process's name is 0
  std::string field;
  for (int i = 0; i < kStartTime; ++i) fields >> field;
  timespec t{};
  clock_gettime(CLOCK_BOOTTIME, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec) -
         std::strtod(field.c_str(), nullptr) / static_cast<double>(::sysconf(_SC_CLK_TCK));
}

}  // namespace typodont

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "calibration/camera_solver.h"
#include "engine/base/csv.h"
#include "engine/base/error.h"
#include "engine/base/units.h"

namespace typodont::calibration {

std::vector<Sighting> read_sightings(const std::filesystem::path& file) {
  const CsvTable table = read_csv(file, {"picture", "on", "px", "py"}, {"u", "v", "x_mm", "y_mm", "z_mm"});
  std::vector<Sighting> sightings;
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    const auto at = [&](const char* name) { return table.value(i, name); };
    const auto need = [&](const char* name) {
      const double value = at(name);
      if (!std::isfinite(value)) table.fail(i, name, "nothing", "a number");
      return value;
    };
    const auto whole = [&](const char* name, double high) {
      const double value = at(name);
      if (value != std::floor(value) || value < 0 || value > high) {
        table.fail(i, name, fmt::format("{}", value), fmt::format("a whole number, 0 to {}", high));
      }
      return static_cast<int>(value);
    };
    Sighting s{whole("picture", 1e6), static_cast<SeenOn>(whole("on", 2)), {}, {}, at("px"), at("py")};
    if (s.on == SeenOn::kTouchedPoint)
      s.touched_W = dvec3(need("x_mm"), need("y_mm"), need("z_mm")) * kMillimetre;
    else
      s.corner = {need("u"), need("v")};
    sightings.push_back(s);
  }
  return sightings;
}

BoardPicture draw_board(int columns, int rows, int width, int height) {
  if (columns < 3 || rows < 3 || (columns + rows) % 2 == 0) {
    throw Error(
        fmt::format("board: found {} by {} inner corners, expected at least 3 by 3 with an odd sum", columns, rows));
  }
  BoardPicture board{
      width,
      height,
      std::vector<unsigned char>(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), 255),
      {}};
  // Cells have whole pixels, and the board has a white border of one cell.
  const int cell = std::min(width / (columns + 3), height / (rows + 3));
  if (cell < 4)
    throw Error(fmt::format("board: found {} by {} pixels for {} by {} corners, expected at least four a cell", width,
                            height, columns, rows));
  const int left = (width - cell * (columns + 1)) / 2, top = (height - cell * (rows + 1)) / 2;
  for (int j = 0; j <= rows; ++j) {
    for (int i = 0; i <= columns; ++i) {
      // Cell (1, 1) is dark, and then every second cell.
      if ((i + j) % 2 != 0) continue;
      for (int y = 0; y < cell; ++y) {
        for (int x = 0; x < cell; ++x) {
          board.grey[static_cast<std::size_t>(top + j * cell + y) * static_cast<std::size_t>(width) +
                     static_cast<std::size_t>(left + i * cell + x)] = 0;
        }
      }
    }
  }
  for (int j = 1; j <= rows; ++j) {
    for (int i = 1; i <= columns; ++i) {
      board.corners.push_back(
          {static_cast<double>(left + i * cell) / width, 1 - static_cast<double>(top + j * cell) / height});
    }
  }
  return board;
}

}  // namespace typodont::calibration

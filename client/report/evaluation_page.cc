#include "client/report/evaluation_page.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>
#include <absl/time/clock.h>
#include <absl/time/time.h>

#include <utility>

#include "client/report/evaluation_tables.h"
#include "client/report/page.h"

namespace isthmus::report {
namespace {

using Tile = std::pair<std::string, std::string>;

// The figures that a reader wants first.
std::vector<Tile> TilesOf(const evaluation::Evaluation& evaluation) {
  std::vector<Tile> tiles;
  for (const evaluation::EvaluatedTrajectory& robot : evaluation.robots) {
    tiles.push_back(
        {absl::StrFormat("%.3f m", robot.absolute.rmse_m), absl::StrCat("ATE RMSE, ", robot.name)});
    if (robot.drift.lengths.empty()) continue;
    tiles.push_back({absl::StrFormat("%.2f %%", robot.drift.percent),
                     absl::StrCat("of the way, ", robot.name)});
  }
  if (evaluation.all) {
    tiles.push_back({absl::StrFormat("%.3f m", evaluation.all->rmse_m), "ATE RMSE in one frame"});
  }
  return tiles;
}

}  // namespace

absl::StatusOr<std::string> EvaluationPage(const evaluation::Evaluation& evaluation,
                                           const std::vector<Figure>& figures,
                                           const std::string& folder) {
  Page page("Trajectories against the truth",
            absl::FormatTime("%Y-%m-%d %H:%M:%S UTC", absl::Now(), absl::UTCTimeZone()));
  page.Tiles(TilesOf(evaluation));
  page.Section("How it was compared");
  for (const std::string& sentence : MethodOf(evaluation)) page.Paragraph(sentence);
  page.Section("Errors");
  for (const Table& table : TablesOf(evaluation)) page.Add(table);
  if (!figures.empty()) page.Section("Figures");
  for (const Figure& figure : figures) {
    const auto svg = InlineSvg(folder, figure["file"].get<std::string>());
    if (!svg.ok()) return svg.status();
    page.Figure(*svg, figure["title"].get<std::string>());
  }
  return page.Html();
}

}  // namespace isthmus::report

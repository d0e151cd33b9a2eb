#include "client/report/server_page.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/client/report/server_states.h"

namespace isthmus::report {
namespace {

using testing::HasSubstr;
using testing::Not;

constexpr char kEvil[] = "<script>alert('x')</script>";

TEST(ServerPage, EscapesAllThatComesFromOutside) {
  ServerState state = TwoApart(MatchReason::kByHand, kEvil, kEvil);
  state.address = state.info.storage_problem = kEvil;
  state.info.damaged = {kEvil};
  for (SessionStatus& session : state.sessions) {
    session.record.sensor = session.archive_problem = kEvil;
  }
  MatchEdge& edge = state.graph.matches[0];
  edge.match.detail = kEvil;
  edge.manual_decision = ManualDecision();
  edge.manual_decision->note = kEvil;
  Loop loop;
  loop.loop.session = state.sessions[0].record.id;
  loop.loop.detail = loop.loop.note = kEvil;
  loop.loop.rejected = true;
  state.loops = {loop};
  RevisionInfo revision;
  revision.cause = kEvil;
  state.revisions = {revision};
  const auto page = ServerPage(state, {}, "");
  ASSERT_TRUE(page.ok()) << page.status();
  EXPECT_THAT(*page, Not(HasSubstr("<script")));
  EXPECT_THAT(*page, HasSubstr("&lt;script&gt;alert(&#39;x&#39;)&lt;/script&gt;"));
  EXPECT_THAT(*page, HasSubstr("default-src 'none'"));
}

TEST(ServerPage, LoadsNothing) {
  const auto page = ServerPage(TwoApart(MatchReason::kLowOverlap), {}, "");
  ASSERT_TRUE(page.ok());
  EXPECT_THAT(*page, testing::StartsWith("<!DOCTYPE html>"));
  EXPECT_THAT(*page, testing::EndsWith("</html>\n"));
  for (const char* word : {"http://", "https://", "src=", "href=", "@import", "<link"}) {
    EXPECT_THAT(*page, Not(HasSubstr(word)));
  }
}

TEST(ServerPage, AnEmptyServerHasAPageToo) {
  const auto page = ServerPage(ServerState(), {}, "");
  ASSERT_TRUE(page.ok());
  EXPECT_THAT(*page, HasSubstr("No robot has come yet."));
}

}  // namespace
}  // namespace isthmus::report

// A session's description of the scans it gets.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/server/ingest/worker_fixture.h"

namespace isthmus::ingest {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using testing::Rig;

TEST(Input, IsEmptyBeforeTheFirstScan) { EXPECT_EQ(Rig().worker().Status().input, ""); }

TEST(Input, NamesTheFieldsThatWereUsed) {
  Rig rig;
  rig.Send(rig.Turn(0));
  EXPECT_EQ(rig.worker().Status().input,
            "rings: 16, given by field 'ring'; times: given by field 'time' (s, up to the end of "
            "the scan)");
}

TEST(Input, SaysThatScansAreCompensatedAlready) {
  Rig rig;
  Scan scan = rig.Turn(0);
  for (ScanPoint& p : scan.points) p.time = 0;
  EXPECT_EQ(rig.Send(scan).outcome, ScanOutcome::kProcessed);
  EXPECT_THAT(rig.worker().Status().input,
              HasSubstr("times: given by field 'time' (all 0: motion-compensated already)"));
}

TEST(Input, SaysWhatWasInferred) {
  for (const char* sensor : {"vlp16", "spinning"}) {
    Rig rig(sensor);
    Scan scan = rig.Turn(0);
    scan.has_ring = scan.has_time = false;
    const ScanAck ack = rig.Send(scan);
    EXPECT_EQ(ack.outcome, ScanOutcome::kProcessed) << ack.reason;
    EXPECT_THAT(rig.worker().Status().input,
                AllOf(HasSubstr("rings: 16, by the"), HasSubstr("elevations"),
                      HasSubstr("times: from azimuth, clockwise from 180 deg")));
  }
}

TEST(Input, SaysWhatDoesNotFitTheSensorsName) {
  Rig rig("os0-128");
  rig.Send(rig.Turn(0));
  EXPECT_THAT(rig.worker().Status().input, HasSubstr("16 rings seen, but a os0-128 has 128"));
}

TEST(Input, SaysWhyNothingWorks) {
  Rig rig("vlp16");
  Scan scan = rig.Turn(0);
  for (ScanPoint& p : scan.points) p.ring = static_cast<uint16_t>(4 * p.ring);
  const ScanAck ack = rig.Send(scan);
  EXPECT_EQ(ack.outcome, ScanOutcome::kRejected);
  EXPECT_THAT(ack.reason, AllOf(HasSubstr("rings up to number 60"), HasSubstr("vlp16 has 16")));
  EXPECT_THAT(rig.worker().Status().input,
              AllOf(HasSubstr("no scan could be used"), HasSubstr("number 60")));
}

}  // namespace
}  // namespace isthmus::ingest

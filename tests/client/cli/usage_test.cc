// Answers to a person who mistypes, names a missing file, or brings damaged ones.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "tests/client/cli/program.h"

namespace isthmus::cli {
namespace {

using testing::AllOf;
using testing::HasSubstr;

// Nobody listens on port 1.
constexpr char kNowhere[] = " --server 127.0.0.1:1 --attempts 1";

TEST(Usage, AMissingFolderForTheOutputGivesFive) {
  for (const char* command : {"export --format ply -o /no/such/map.ply", "query -o /no/such/q.pcd",
                              "trajectory alice -o /no/such/a.tum", "picture -o /no/such/map.png",
                              "graph --g2o /no/such/graph.g2o"}) {
    const ProgramResult result = Isthmus(command + std::string(kNowhere));
    EXPECT_EQ(result.code, 5) << command;
    EXPECT_THAT(result.err, HasSubstr("there is no folder /no/such; make it first"));
  }
}

TEST(Usage, AnExtensionThatIsNotTrueGivesTwo) {
  const std::pair<const char*, const char*> cases[] = {
      {"export --format pcd -o x.laz", ".pcd"},
      {"export --format las -o x.pcd", ".las"},
      {"export --format nav2 -o x.png", ".yaml or .pgm"},
      {"export -o x.pdf", "does not tell the format"},
      {"export -o x", "does not tell the format"},
      {"query -o x.las", ".pcd"},
      {"picture -o x.svg", ".png"},
      {"report -o x.pdf", ".html or .htm"},
      {"trajectory alice -o x.csv", ".tum or .txt"},
      {"trajectory alice --format kitti -o x.tum", ".txt or .kitti"},
      {"changes --since 1h --picture x.jpg", ".png"},
      {"graph --g2o x.json", ".g2o"},
      {"merge a.pcd b.pcd -o x.las", ".pcd or .ply"},
      {"odometry scans -o x.csv", ".tum or .txt"}};
  for (const auto& [command, wanted] : cases) {
    const ProgramResult result = Isthmus(command + std::string(kNowhere));
    EXPECT_EQ(result.code, 2) << command;
    EXPECT_THAT(result.err, HasSubstr(wanted)) << command;
  }
}

TEST(Usage, TextThatIsNotUtf8GivesTwo) {
  for (const char* command :
       {"match reject a b --note 'x\xff'", "trajectory 'x\xff'", "loops reject 3 --note='x\xff'"}) {
    const ProgramResult result = Isthmus(command + std::string(kNowhere));
    EXPECT_EQ(result.code, 2) << command;
    EXPECT_THAT(result.err, HasSubstr("x?\" is not text in UTF-8"));
  }
}

TEST(Usage, ABoxWhoseCornersAreExchangedGivesTwo) {
  const std::string box = " --box 5,5,5,-5,-5,-5 -o x";
  for (const char* command : {"export --format nav2", "export --format autoware",
                              "export --format pcd", "export --format las", "export --format bt"}) {
    const ProgramResult result = Isthmus(command + box + kNowhere);
    EXPECT_EQ(result.code, 2) << command;
    EXPECT_THAT(result.err, HasSubstr("exceeds box.max")) << command;
  }
}

TEST(Usage, HeightsThatAreNoneGiveTwo) {
  for (const char* heights :
       {"--min-z=inf", "--max-z=-inf", "--min-z=nan", "--max-z=1e400", "--min-z 5 --max-z 1"}) {
    for (const char* command : {"query -o x.pcd ", "export -o x.pcd ", "picture -o x.png "}) {
      const ProgramResult result = Isthmus(command + std::string(heights) + kNowhere);
      EXPECT_EQ(result.code, 2) << command << heights;
      EXPECT_THAT(result.err, HasSubstr("-z")) << command << heights;
    }
  }
}

// It gets as far as to look for the server, of which there is none.
TEST(Usage, TheExtensionTellsTheFormatOfAnExport) {
  const std::string folder = ScratchFolder();
  for (const char* name :
       {"x.pcd", "X.PLY", "x.bt", "x.ot", "x.las", "x.mcap", "x.yaml", "x.geojson", "x.kml"}) {
    EXPECT_EQ(Isthmus("export -o " + folder + "/" + name + kNowhere).code, 4) << name;
  }
  EXPECT_EQ(Isthmus("export --format ply -o " + folder + "/2026.11.28" + kNowhere).code, 4);
}

// A shell leaves that of a variable that is not set.
TEST(Usage, AnOptionWithoutAValueGivesTwo) {
  for (const char* command : {"push x --robot a --spool ''", "status --token-file ''",
                              "push x --robot ''", "export -o x.pcd --tls-ca ''"}) {
    const ProgramResult result = Isthmus(command + std::string(kNowhere));
    EXPECT_EQ(result.code, 2) << command;
    EXPECT_THAT(result.err, HasSubstr("has no value")) << command;
  }
}

// It would be the default site, where space around a name were let go of.
TEST(Usage, WhatCannotNameASiteGivesTwo) {
  for (const char* site : {"' '", "'default '", "'\t'", "a/b", ".hidden"}) {
    const ProgramResult result = Isthmus("status --site " + std::string(site) + kNowhere);
    EXPECT_EQ(result.code, 2) << site;
    EXPECT_THAT(result.err, HasSubstr("cannot name a site")) << site;
  }
}

TEST(Usage, HelpNamesEveryCommand) {
  const ProgramResult help = Isthmus("--help");
  EXPECT_EQ(help.code, 0);
  for (const char* command :
       {"simulate", "push",      "status",  "robots",   "graph",    "trajectory", "transform",
        "query",    "export",    "picture", "odometry", "merge",    "rebuild",    "match",
        "loops",    "revisions", "anchor",  "datum",    "optimize", "eval",       "bench",
        "report",   "info",      "upload",  "log",      "watch",    "copy"}) {
    EXPECT_THAT(help.out, HasSubstr(command));
    EXPECT_EQ(Isthmus(std::string(command) + " --help").code, 0) << command;
  }
}

TEST(Usage, MistakesOnTheCommandLineGiveTwo) {
  EXPECT_EQ(Isthmus("").code, 2);
  EXPECT_EQ(Isthmus("query --max-points -1 --server 127.0.0.1:1").code, 2);
  for (const char* option : {"info x --from", "info x --to", "watch --steps", "log --limit"}) {
    EXPECT_EQ(Isthmus(std::string(option) + " -1").code, 2) << option;
    EXPECT_EQ(Isthmus(std::string(option) + " 99999999999999999999").code, 2) << option;
  }
  EXPECT_EQ(Isthmus("info x --stamps middle").code, 2);
  EXPECT_EQ(Isthmus("conquer").code, 2);
  EXPECT_EQ(Isthmus("status --verbosity").code, 2);
  EXPECT_EQ(Isthmus("transform alice").code, 2);
  EXPECT_EQ(Isthmus("export --format dxf -o map").code, 2);
  EXPECT_EQ(Isthmus("merge one.pcd -o merged.pcd").code, 2);
  const ProgramResult rate = Isthmus("push --robot a --rate fast /");
  EXPECT_EQ(rate.code, 2);
  EXPECT_THAT(rate.err, HasSubstr("--rate"));
}

TEST(Usage, HelpIsACommandToo) {
  EXPECT_EQ(Isthmus("help").out, Isthmus("--help").out);
  for (const char* command : {"push", "match reject", "simulate", "bench paper"}) {
    const ProgramResult help = Isthmus("help " + std::string(command));
    EXPECT_EQ(help.code, 0) << command;
    EXPECT_EQ(help.out, Isthmus(std::string(command) + " --help").out) << command;
  }
}

TEST(Usage, ACommandThatIsNoneIsToldTheNearest) {
  const std::vector<std::pair<std::string, std::string>> slips = {{"stats", "status"},
                                                                  {"help simulat", "simulate"},
                                                                  {"match rejekt a b", "reject"},
                                                                  {"bench papr", "paper"}};
  for (const auto& [typed, meant] : slips) {
    const ProgramResult result = Isthmus(typed);
    EXPECT_EQ(result.code, 2) << typed;
    EXPECT_THAT(result.err, HasSubstr("did you mean `" + meant + "`?"));
    EXPECT_EQ(result.out, "");
  }
}

TEST(Usage, AnOptionThatIsNoneIsNamed) {
  for (const char* typed : {"--bogus", "--bogus=3", "token --bogus", "status --bogus",
                            "--attempts 1 --bogus status", "help token --bogus"}) {
    const ProgramResult result = Isthmus(typed);
    EXPECT_EQ(result.code, 2) << typed;
    EXPECT_THAT(result.err, AllOf(testing::StartsWith("isthmus: "), HasSubstr("--bogus"))) << typed;
  }
  EXPECT_THAT(Isthmus("").err, testing::StartsWith("isthmus: "));
  EXPECT_EQ(Isthmus("--version").code, 0);
}

TEST(Usage, TheServerMayBeNamedBeforeTheCommand) {
  for (const char* command : {"status", "match reject a b", "revisions diff 1"}) {
    const ProgramResult result =
        Isthmus("--server=127.0.0.1:1 --attempts 1 " + std::string(command));
    EXPECT_EQ(result.code, 4) << command;
    EXPECT_THAT(result.err, HasSubstr("127.0.0.1:1")) << command;
  }
  EXPECT_EQ(Isthmus("--server 127.0.0.1:1 eval").code, 2) << "it takes none, wherever it stands";
}

TEST(Usage, AnAddressThatIsNoneGivesTwoAndSaysWhatToWrite) {
  for (const char* address : {"localhost:70000", "localhost:0", "localhost", "localhost:http"}) {
    const ProgramResult result = Isthmus("status --server " + std::string(address));
    EXPECT_EQ(result.code, 2) << address;
    EXPECT_THAT(result.err, HasSubstr("write HOST:PORT, as in localhost:50051")) << address;
  }
}

TEST(Usage, ABoxThatIsNoBoxIsToldWithoutAServer) {
  const ProgramResult box = Isthmus("query --box 1,2,3,4,5 -o x.pcd" + std::string(kNowhere));
  EXPECT_EQ(box.code, 2);
  EXPECT_THAT(box.err, HasSubstr("--box is x0,y0,z0,x1,y1,z1"));
  EXPECT_EQ(Isthmus("query --box 1,2,3,4,5,six -o x.pcd").code, 2);
  EXPECT_EQ(Isthmus("query --sphere 1,2,3 -o x.pcd").code, 2);
  EXPECT_EQ(Isthmus("query --box 0,0,0,1,1,1 --sphere 0,0,0,1 -o x.pcd").code, 2);
  const ProgramResult polygon = Isthmus("query --polygon 1,2,3 -o x.pcd" + std::string(kNowhere));
  EXPECT_EQ(polygon.code, 2);
  EXPECT_THAT(polygon.err, HasSubstr("--polygon is x0,y0,x1,y1,x2,y2,..."));
  EXPECT_EQ(Isthmus("query --corridor 0,0,0,1,1,1 -o x.pcd").code, 2) << "without --width";
  EXPECT_EQ(Isthmus("query --oriented-box 0,0,0,90,1,1 -o x.pcd").code, 2);
  EXPECT_EQ(Isthmus("query --seen-since yesterday -o x.pcd").code, 2);
  EXPECT_EQ(Isthmus("export --format nav2 --polygon 0,0,1,0,1,1 -o x").code, 2);
}

TEST(Usage, AServerThatIsNotThereGivesFourAndSaysWhatToDo) {
  for (const char* command :
       {"status", "robots", "graph", "transform a b", "trajectory a -o x.tum", "query -o x.pcd",
        "export --format pcd -o x.pcd", "picture -o x.png", "report -o x.html", "revisions",
        "revisions diff 1", "revisions undo 1", "loops", "loops reject 1", "graph --g2o x.g2o",
        "log", "anchor list", "anchor remove alice-1/0",
        "anchor set alice --position 1 2 3 --sigma-xy 1"}) {
    const ProgramResult result = Isthmus(command + std::string(kNowhere));
    EXPECT_EQ(result.code, 4) << command;
    EXPECT_THAT(result.err, AllOf(HasSubstr("cannot reach isthmus-server at 127.0.0.1:1"),
                                  HasSubstr("isthmus-server --data DIR")));
    EXPECT_EQ(result.out, "") << command;
  }
}

TEST(Usage, NoNameCommandsTheTerminal) {
  const ProgramResult result =
      Isthmus("push \"$(printf '/no/such/\\033[2J\\007')\"" + std::string(kNowhere));
  EXPECT_NE(result.code, 0);
  EXPECT_THAT(result.err, HasSubstr("/no/such/\\x1b[2J\\x07"));
  EXPECT_THAT(result.err, testing::Not(HasSubstr("\033")));
}

TEST(Usage, FoldersThatCannotBeUsedGiveFiveBeforeTheServerIsAsked) {
  const std::string push = "push --robot alice" + std::string(kNowhere) + " ";
  const ProgramResult missing = Isthmus(push + "/no/such/folder");
  EXPECT_EQ(missing.code, 5);
  EXPECT_THAT(missing.err, HasSubstr("/no/such/folder does not exist"));
  const std::string empty = ScratchFolder();
  EXPECT_EQ(Isthmus(push + empty).code, 5);
  EXPECT_EQ(Isthmus("odometry " + empty + " -o x.tum").code, 5);
}

TEST(Usage, FilesOfTokensAndCertificatesThatCannotBeUsedGiveFive) {
  for (const char* option : {"--token-file /no/such", "--token-file /tmp", "--tls-ca /no/such"}) {
    const ProgramResult result = Isthmus("status " + std::string(option) + kNowhere);
    EXPECT_EQ(result.code, 5) << result.err;
  }
  const std::string folder = ScratchFolder();
  ASSERT_EQ(Isthmus("certs init " + folder + "/certs --host localhost --client alice").code, 0);
  const std::string certs = folder + "/certs/";
  std::ofstream(folder + "/blank") << " \n";
  const std::string trusting = " --tls-ca " + certs + "ca.pem --tls-cert " + certs;
  const std::pair<std::string, const char*> wrong[] = {
      {"--token-file " + folder + "/blank", "/blank is empty"},
      {"--tls-ca " + certs + "server.key", "server.key is no certificate"},
      {"--tls-ca " + folder + "/blank", "blank is no certificate"},
      {trusting + "alice.key --tls-key " + certs + "alice.key", "alice.key is no certificate"},
      {trusting + "alice.pem --tls-key " + certs + "server.key", "server.key is not the key of"},
      {trusting + "alice.pem --tls-key " + folder + "/blank", "blank holds no private key"}};
  for (const auto& [options, said] : wrong) {
    const ProgramResult result = Isthmus("status " + options + kNowhere);
    EXPECT_EQ(result.code, 5) << options;
    EXPECT_THAT(result.err, HasSubstr(said));
  }
  EXPECT_EQ(Isthmus("status --tls-cert " + certs + "alice.pem" + kNowhere).code, 2);
}

TEST(Usage, MergeNamesTheFileThatLies) {
  const std::string folder = ScratchFolder();
  const std::string header =
      "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 1000000\nHEIGHT 1\n"
      "VIEWPOINT 0 0 0 1 0 0 0\nPOINTS 1000000\nDATA binary\n";
  std::ofstream(folder + "/lying.pcd") << header << "only a few bytes";
  const ProgramResult lying =
      Isthmus("merge " + folder + "/lying.pcd " + folder + "/none.pcd -o " + folder + "/m.pcd");
  EXPECT_EQ(lying.code, 5);
  EXPECT_THAT(lying.err, HasSubstr("lying.pcd"));
  EXPECT_FALSE(std::filesystem::exists(folder + "/m.pcd"));
}

TEST(Usage, AWorldThatDoesNotExistIsAUsageError) {
  EXPECT_EQ(Isthmus("simulate --world atlantis -o " + ScratchFolder()).code, 2);
}

TEST(Usage, MoreWalkersOrCarsThanAWorldTakesAreUsageErrors) {
  const std::string simulate = "simulate -o " + ScratchFolder() + " ";
  const ProgramResult walkers = Isthmus(simulate + "--walkers -1");
  EXPECT_EQ(walkers.code, 2);
  EXPECT_THAT(walkers.err, HasSubstr("walkers must be 0 to 1000"));
  const ProgramResult cars = Isthmus(simulate + "--world campus --cars 101");
  EXPECT_EQ(cars.code, 2);
  EXPECT_THAT(cars.err, HasSubstr("cars must be 0 to 100"));
  const ProgramResult indoors = Isthmus(simulate + "--world museum --cars 3");
  EXPECT_EQ(indoors.code, 2);
  EXPECT_THAT(indoors.err, AllOf(HasSubstr("no streets"), HasSubstr("museum")));
}

}  // namespace
}  // namespace isthmus::cli

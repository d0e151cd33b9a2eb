// Pages, logging in, files of the map, and who is turned away.
#include "server/web/web_server.h"

#include "tests/server/web/web_fixture.h"

namespace isthmus::web {
namespace {

using testing::AllOf;
using testing::EndsWith;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

class WebServerTest : public WebTest {};

TEST_F(WebServerTest, ThePageComesPackedOrNotAndMayDoNothingElse) {
  Start();
  const http::Reply page = Get("/");
  EXPECT_EQ(page.code, 200);
  EXPECT_EQ(page.headers.at("content-type"), "text/html; charset=utf-8");
  EXPECT_EQ(page.headers.at("cache-control"), "no-cache");
  EXPECT_THAT(page.body, AllOf(StartsWith("<!doctype html>"), EndsWith("</html>\n")));
  EXPECT_THAT(page.headers.at("content-security-policy"),
              AllOf(StartsWith("default-src 'none'; script-src 'self';"),
                    HasSubstr("frame-ancestors 'none'")));
  EXPECT_EQ(page.headers.at("x-content-type-options"), "nosniff");
  EXPECT_EQ(page.headers.at("referrer-policy"), "no-referrer");

  const http::Reply script = Get("/assets/main-1a2b3c4d.js");
  const http::Reply packed = Get("/assets/main-1a2b3c4d.js", "Accept-Encoding: br, gzip\r\n");
  EXPECT_THAT(script.body, HasSubstr("document.title"));
  EXPECT_THAT(script.headers.at("cache-control"), HasSubstr("immutable"));
  EXPECT_EQ(script.headers.count("content-encoding"), 0u);
  EXPECT_EQ(packed.headers.at("content-encoding"), "gzip");
  EXPECT_THAT(packed.body, StartsWith("\x1f\x8b"));
  EXPECT_LT(packed.body.size(), script.body.size());
  EXPECT_EQ(Get("/short.txt", "Accept-Encoding: gzip\r\n").body, "x");  // No smaller for packing.
  const http::Reply head = http::Ask(address_, "HEAD", "/");
  EXPECT_EQ(head.code, 200);
  EXPECT_EQ(head.body, "");
  EXPECT_EQ(head.headers.at("content-length"), std::to_string(page.body.size()));
}

TEST_F(WebServerTest, ThereIsNoWayToOtherFiles) {
  Start();
  for (const char* path : {"/../../etc/passwd", "/etc/passwd", "/%2e%2e/%2e%2e/etc/passwd",
                           "/assets/../../CMakeLists.txt", "//etc/passwd", "/index.html%00.js",
                           "/healthz%00", "/index.html/", "/assets", "/..%5c..%5cetc%5cpasswd"}) {
    const http::Reply reply = Get(path);
    EXPECT_EQ(reply.code, 404) << path;
    EXPECT_THAT(reply.body, Not(HasSubstr("root:")));
  }
  EXPECT_EQ(http::Ask(address_, "PUT", "/index.html", "", "mine").code, 405);
  EXPECT_EQ(http::Ask(address_, "DELETE", "/index.html").code, 405);
  EXPECT_THAT(Get("/").body, StartsWith("<!doctype html>"));
}

TEST_F(WebServerTest, AServerWithoutAViewerSaysSo) {
  Start();
  const Assets none;
  const auto bare = *WebServer::Start(options_, *server_, none);
  const std::string address = bare->url().substr(std::string("http://").size());
  const http::Reply reply = http::Ask(address, "GET", "/");
  EXPECT_EQ(reply.code, 404);
  EXPECT_THAT(reply.body, HasSubstr("ISTHMUS_VIEWER"));
  EXPECT_EQ(http::Ask(address, "GET", "/healthz").body, "ok\n");
}

TEST_F(WebServerTest, ATokenBecomesACookieThatNoScriptReads) {
  const std::string reader = NewToken("eve", AccessRole::kReader);
  const std::string robot = NewToken("alice", AccessRole::kRobot);
  Start();
  const http::Reply in = Post("/login", "{\"token\": \"" + reader + "\"}");
  EXPECT_EQ(in.code, 200);
  EXPECT_EQ(in.headers.at("set-cookie"),
            "isthmus_token=" + reader + "; Path=/; HttpOnly; SameSite=Strict");
  EXPECT_EQ(Post("/login", R"({"token": "isthmus_wrong"})").code, 401);
  EXPECT_EQ(Post("/login", "{\"token\": \"" + robot + "\"}").code, 403);
  for (const char* nonsense : {"", "{", "[]", "{}", R"({"token": 1})", R"({"token": ""})",
                               R"({"token": "a\r\nSet-Cookie: b=c"})", R"({"token": "a;b"})"}) {
    const http::Reply reply = Post("/login", nonsense);
    EXPECT_EQ(reply.code, 400) << nonsense;
    EXPECT_EQ(reply.headers.count("set-cookie"), 0u);
  }
  EXPECT_EQ(Get("/login").code, 405);
  // A token that a page sends counts for more than the cookie that it has.
  EXPECT_EQ(Post("/login", R"({"token": "isthmus_wrong"})", Bearer(reader)).code, 401);
  const http::Reply out = Post("/logout", "{}");
  EXPECT_THAT(out.headers.at("set-cookie"), HasSubstr("isthmus_token=; "));
  EXPECT_THAT(out.headers.at("set-cookie"), HasSubstr("Max-Age=0"));
  EXPECT_EQ(out.headers.at("clear-site-data"), "\"cache\"");
}

TEST_F(WebServerTest, PagesOfOthersChangeNothing) {
  pipeline_.undo = 8;
  Start();
  const auto undo = [this](const std::string& headers) {
    return http::Ask(address_, "POST", "/rpc/isthmus.v1.EditService/UndoRevision", headers,
                     R"({"revision": "7"})")
        .code;
  };
  const std::string type = "Content-Type: application/json\r\n";
  EXPECT_EQ(undo(type + "Origin: http://evil.example\r\n"), 403);
  EXPECT_EQ(undo(type + "Origin: http://" + address_ + ".evil.example\r\n"), 403);
  EXPECT_EQ(undo(type + "Origin: http://127.0.0.1:1\r\n"), 403);  // Another server here.
  EXPECT_EQ(undo(type + "Origin: null\r\n"), 403);
  EXPECT_EQ(undo(""), 400);  // As forms send it:
  EXPECT_EQ(undo("Content-Type: text/plain\r\n"), 400);
  EXPECT_EQ(undo("Content-Type: application/x-www-form-urlencoded\r\n"), 400);
  EXPECT_EQ(undo("Content-Type: multipart/form-data; boundary=application/json\r\n"), 400);
  EXPECT_TRUE(pipeline_.actors.empty());
  EXPECT_EQ(undo(type + "Origin: http://" + address_ + "\r\n"), 200);
  EXPECT_EQ(Post("/login", R"({"token": "x"})", "Origin: http://evil.example\r\n").code, 403);
}

TEST_F(WebServerTest, NamesThatOthersPointHereAreNotOurs) {
  options_.hosts = "maps.example other.example";
  Start();
  const auto asked_as = [this](const std::string& host) {
    return Get("/healthz", "Host: " + host + "\r\n").code;
  };
  for (const char* ours : {"127.0.0.1", "127.0.0.1:8080", "[::1]:8080", "localhost:1", "LOCALHOST",
                           "192.168.1.2", "maps.example", "Other.example:443"}) {
    EXPECT_EQ(asked_as(ours), 200) << ours;
  }
  for (const char* theirs : {"evil.example", "evil.example:8080", "localhost.evil.example",
                             "127.0.0.1.evil.example", "127.0.0.1, evil.example", "example", ""}) {
    EXPECT_NE(asked_as(theirs), 200) << theirs;
  }
}

TEST_F(WebServerTest, AnAddressThatIsNoTextIsRefused) {
  Start();
  for (const char* address :
       {"/export/map.pcd?map=%ff", "/export/map.pcd?component=%ff", "/export/map.pcd?%ff=1",
        "/export/map.pcd?site=%ff", "/tiles/%ff/0/0/0.pts", "/floors/%ff", "/trajectories/%ff.tum",
        "/autoware/%ff/pointcloud_map_metadata.yaml", "/vda5050/%ff/map.pcd", "/%ff"}) {
    const http::Reply reply = Get(address);
    EXPECT_EQ(reply.code, 400) << address;
    EXPECT_THAT(reply.body, HasSubstr("UTF-8")) << address;
  }
}

TEST_F(WebServerTest, TheMapIsDownloadedAsAFile) {
  pipeline_.file = {"one ", "two"};
  const std::string reader = NewToken("eve", AccessRole::kReader);
  Start();
  const std::string cookie = "Cookie: isthmus_token=" + reader + "\r\n";
  const http::Reply file =
      Get("/export/map.ply?component=1&resolution=0.2&box=-1,-2,-3,4,5,6.5", cookie);
  EXPECT_EQ(file.code, 200);
  EXPECT_EQ(file.body, "one two");
  EXPECT_TRUE(file.is_whole);
  EXPECT_EQ(file.headers.at("content-disposition"), "attachment; filename=\"map.ply\"");
  ASSERT_EQ(pipeline_.exports.size(), 1u);
  EXPECT_EQ(pipeline_.exports[0].format, ExportFormat::kPly);
  EXPECT_EQ(pipeline_.exports[0].component, 1u);
  EXPECT_EQ(pipeline_.exports[0].resolution_m, 0.2);
  EXPECT_EQ(pipeline_.exports[0].box->max.z(), 6.5);

  EXPECT_EQ(Get("/export/map.ply?map=alice-1", cookie).code, 200);
  EXPECT_EQ(pipeline_.exports[1].component, MapName(SessionId("alice-1")));
  EXPECT_EQ(Get("/export/map.ply?map=" + std::string(97, 'a'), cookie).code, 400);
  EXPECT_EQ(Get("/export/map.ply").code, 401);
  EXPECT_EQ(Get("/export/map.exe", cookie).code, 404);
  EXPECT_EQ(Get("/export/", cookie).code, 404);
  for (const char* query : {"resolution=x", "box=1,2,3", "box=1,2,3,4,5,x", "box=9,9,9,1,1,1"}) {
    EXPECT_EQ(Get(std::string("/export/map.pcd?") + query, cookie).code, 400) << query;
  }
  EXPECT_EQ(http::Ask(address_, "POST", "/export/map.pcd", cookie).code, 405);
}

TEST_F(WebServerTest, AFileThatBreaksOffIsNotTakenForWhole) {
  pipeline_.file = {std::string(3 << 20, 'a')};
  pipeline_.export_status = absl::DataLossError("the disk");
  Start();
  const http::Reply file = Get("/export/map.pcd");
  EXPECT_TRUE(file.code != 200 || !file.is_whole) << file.code;
}

TEST(WebOptionsTest, OtherMachinesAreServedOverTlsOrWhereTheSettingsSaySo) {
  WebOptions options;
  EXPECT_TRUE(CheckListening(options).ok());
  options.listen = "127.0.0.1:0";
  EXPECT_TRUE(CheckListening(options).ok());
  options.listen = "0.0.0.0:8443";
  EXPECT_TRUE(absl::IsFailedPrecondition(CheckListening(options)));
  options.insecure = true;
  EXPECT_TRUE(CheckListening(options).ok());
  options.insecure = false;
  options.tls = {"server.pem", "server.key"};
  EXPECT_TRUE(CheckListening(options).ok());
  for (const char* wrong : {"8080", "unix:x", "a:1,b:2", "localhost:99999"}) {
    options.listen = wrong;
    EXPECT_TRUE(absl::IsInvalidArgument(CheckListening(options))) << wrong;
  }
}

}  // namespace
}  // namespace isthmus::web

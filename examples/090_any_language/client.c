/* A controller of pendulum.scene.xml in C: cc client.c -o client && ./client [PATH]
 * It reads the two numbers that it needs instead of all JSON; a larger program would use a library for that. */
#include <arpa/inet.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

static void fail(const char* what) {
  perror(what);
  exit(1);
}

static void send_all(int link, const char* text) {
  uint32_t size = htonl((uint32_t)strlen(text));
  char message[512];
  const size_t count = 4 + strlen(text);
  memcpy(message, &size, 4);
  memcpy(message + 4, text, strlen(text));
  if (write(link, message, count) != (ssize_t)count) fail("write");
}

static void exactly(int link, void* to, size_t count) {
  char* at = to;
  while (count > 0) {
    const ssize_t got = read(link, at, count);
    if (got <= 0) fail("the simulation closed the connection");
    at += got;
    count -= (size_t)got;
  }
}

/* The next message; the caller frees it. */
static char* receive(int link) {
  uint32_t size;
  exactly(link, &size, 4);
  size = ntohl(size);
  char* text = malloc((size_t)size + 1);
  if (text == NULL) fail("malloc");
  exactly(link, text, size);
  text[size] = '\0';
  return text;
}

/* The first number of this name. */
static double number(const char* text, const char* name) {
  const char* at = strstr(text, name);
  return at == NULL ? 0.0 : strtod(at + strlen(name), NULL);
}

int main(int argc, char** argv) {
  struct sockaddr_un address = {.sun_family = AF_UNIX};
  snprintf(address.sun_path, sizeof address.sun_path, "%s", argc > 1 ? argv[1] : "run.sock");
  const int link = socket(AF_UNIX, SOCK_STREAM, 0);
  for (int tries = 0; connect(link, (struct sockaddr*)&address, sizeof address) != 0; ++tries) {
    if (tries == 600) fail("connect"); /* the simulation may not have started yet */
    usleep(50000);
  }
  send_all(link, "{\"type\":\"hello\",\"protocol\":1}");
  free(receive(link));
  for (;;) {
    char* message = receive(link);
    if (strstr(message, "\"type\":\"update\"") == NULL) break;
    const char* motors = strstr(message, "\"motors\":");
    const double error = 0.5235987755982988 /* 30 degrees */ - number(motors, "\"position\":");
    const double torque = 8.0 * error - 0.4 * number(motors, "\"velocity\":");
    char answer[256];
    snprintf(answer, sizeof answer,
             "{\"type\":\"set\",\"targets\":[%.17g],\"outputs\":{\"output_1\":%.17g}}", torque, error);
    send_all(link, answer);
    free(message);
  }
  close(link);
  return 0;
}

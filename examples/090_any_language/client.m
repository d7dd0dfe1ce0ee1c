% A controller of pendulum.scene.xml in Octave, with Debian's package octave-sockets. Sockets of Octave are TCP, so the
% scene needs connect="tcp:127.0.0.1:5555":
%   octave-cli client.m 127.0.0.1 5555
1;
pkg load sockets

function answer = text_of(message)
  % jsonencode writes 5 digits by default, and numbers here must be exact.
  answer = sprintf('{"type":"set","targets":[%.17g],"outputs":{"output_1":%.17g}}', message.torque, message.error);
end

function bytes = exactly(link, count)
  bytes = uint8([]);
  while numel(bytes) < count
    part = recv(link, count - numel(bytes));
    if isempty(part)
      error('the simulation closed the connection');
    end
    bytes = [bytes, part];
  end
end

function message = receive(link)
  head = double(exactly(link, 4));
  count = head * [2^24; 2^16; 2^8; 1];
  message = char(exactly(link, count));
end

function value = number(text, name)
  % jsondecode rounds the last digit of some numbers.
  value = str2double(regexp(text, ['"' name '":([^,}]*)'], 'tokens', 'once'){1});
end

function transmit(link, text)
  count = numel(text);
  head = uint8(mod(floor(count ./ [2^24, 2^16, 2^8, 1]), 256));
  send(link, [head, uint8(text)]);
end

arguments = argv();
host = '127.0.0.1';
port = 5555;
if numel(arguments) >= 2
  host = arguments{1};
  port = str2double(arguments{2});
end
link = socket(AF_INET, SOCK_STREAM, 0);
for tries = 1:600
  try
    connect(link, struct('addr', host, 'port', port));
    break
  catch
    if tries == 600, rethrow(lasterror()); end
    link = socket(AF_INET, SOCK_STREAM, 0);
    pause(0.05);  % the simulation may not have started yet
  end
end
transmit(link, '{"type":"hello","protocol":1}');
robot = receive(link);
printf('controls %s\n', jsondecode(robot).robot);
goal = 0.5235987755982988;  % 30 degrees
while true
  message = receive(link);
  if isempty(strfind(message, '"type":"update"')), break; end
  answer.error = goal - number(message, 'position');
  answer.torque = 8.0 * answer.error - 0.4 * number(message, 'velocity');
  transmit(link, text_of(answer));
end
disconnect(link);

// Every event of a .xef as KinectXEFTools' own reader gives it: stream, frame, tick, MD5 of its bytes; compiled with it.
using System;
using System.Security.Cryptography;
using KinectXEFTools;

class Dump
{
    static void Main(string[] words)
    {
        using (IEventReader reader = new XEFEventReader(words[0]))
        using (MD5 sum = MD5.Create())
        {
            XEFEvent one;
            while ((one = reader.GetNextEvent()) != null)
            {
                string name = one.EventStream == null ? "" : one.EventStream.Name;
                string bytes = BitConverter.ToString(sum.ComputeHash(one.EventData)).Replace("-", "").ToLower();
                Console.WriteLine(string.Join("\t", name, one.FrameIndex, one.RelativeTime.Ticks, bytes));
            }
        }
    }
}
